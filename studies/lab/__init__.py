"""What instruments of a laboratory record: vibrometer scans, network analysers' files, encoder traces."""
