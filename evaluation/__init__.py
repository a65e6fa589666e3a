"""Campaigns that draw inputs with a known truth and judge what the program makes of them."""
