"""Physical constants."""

G_M_S2 = 9.80665  # standard gravity; local gravity is 9.780 to 9.832
G_MM_S2 = 1e3 * G_M_S2
