"""The verdict on an interface and its machine: does it stick and slip, how strongly, and what does that hang on?"""
