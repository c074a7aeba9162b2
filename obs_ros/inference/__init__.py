"""What one window tells: its objective, prior, noise, jumps, and how far each number is known."""
