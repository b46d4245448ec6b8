"""Simpler methods of diagnosis, to compare with. Each reads the drops of a bench folder
and answers in the solver's schema."""
