"""Photos of spread seeds: outlines to a fraction of a pixel, sizes, elliptic Fourier
terms, and the lot that they make up."""
