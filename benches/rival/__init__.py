"""The same work by other programs; `rivals.py` beside this package runs it."""
