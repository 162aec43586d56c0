"""What requests and answers of a family, or of a device, mean to a shadow."""
