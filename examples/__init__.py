"""Multibody scenes with inextensible cables, each a script of its own: python -m examples.crane"""
