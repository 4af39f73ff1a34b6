"""Two reports beside each other: what became slower or less accurate beyond noise."""
