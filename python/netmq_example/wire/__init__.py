"""Records, spaces and values as bytes: both ends of an environment speak them."""
