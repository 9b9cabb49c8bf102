"""A second stand-in for reality: wheels that roll on a floor, motors with windings, servos that count in integers."""
