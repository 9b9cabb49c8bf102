"""The blind check: a second robot, sealed cases, and the scores of the diagnosis on them."""
