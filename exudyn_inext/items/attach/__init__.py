"""What is attached to a cable: markers at any arc length, bodies at its ends, point masses, drag."""
