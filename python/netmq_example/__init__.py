"""Unity talks to Python over ZeroMQ: what one keeps of the kit's lessons, a module or a folder for each subject."""

import sys

if sys.version_info < (3, 11):
    sys.exit(
        "netmq_example needs Python 3.11 or later, this is %d.%d: get one from https://www.python.org,"
        " and then open a new terminal" % sys.version_info[:2]
    )
