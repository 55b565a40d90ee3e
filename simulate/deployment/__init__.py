"""One deployment: its error, its energy, the gravity study, the export to MuJoCo."""
