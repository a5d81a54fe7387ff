from netmq_example.extras import needed

needed("numpy")
