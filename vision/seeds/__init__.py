"""A photo of spread seeds → length and width of each."""
