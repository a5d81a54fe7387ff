"""The guide in the browser: its pages, and beside each command of theirs a button that runs it on this machine."""
