"""Statistics of a calibration: tables in, tables out; nothing here simulates or looks
at pictures. One method a file."""
