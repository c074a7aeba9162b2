"""The commands, and the entry points of all executables."""
