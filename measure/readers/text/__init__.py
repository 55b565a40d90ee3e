"""Text tables: encoding, delimiter and decimal sign, head, rows."""
