"""The ground floor: keys and units of recordings, air, robust statistics, and what is
believed of whatever a recording does not state."""
