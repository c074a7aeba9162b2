"""The observers of the source papers, and their rivals there."""
