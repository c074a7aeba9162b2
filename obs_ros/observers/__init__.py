"""The observers, each turning samples into estimates."""
