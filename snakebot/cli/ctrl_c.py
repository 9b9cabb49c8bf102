"""Whether Ctrl-C was pressed. What it raises can get lost: some libraries make another error of it, or none."""

pressed = False
