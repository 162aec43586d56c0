"""The twin beside a real controller: it follows the host's requests, and what differs becomes a finding."""
