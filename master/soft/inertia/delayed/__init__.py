"""A slider with mass whose contacts form again one delay after they break: births are known before they come."""
