"""The parts of kit.py: finding lessons, setting up Python and C#, running programs side by side."""
