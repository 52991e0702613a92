"""What holds whatever the network and the hands do: certificates and worst cases, no averages."""
