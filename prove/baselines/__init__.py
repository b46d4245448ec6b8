"""Ways to beat: what one would try first. Each takes the drops of a bench folder, and answers in the solver's schema."""
