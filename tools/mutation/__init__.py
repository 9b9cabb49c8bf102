"""Boards with one fault each, made systematically, and whether the conformance suite finds them."""
