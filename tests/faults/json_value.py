"""Prints the value at a path of keys in a JSON file, numbers with four digits. Numeric keys index lists."""
import json
import sys

value = json.load(open(sys.argv[1]))
for key in sys.argv[2:]:
    value = value[int(key)] if isinstance(value, list) else value[key]
print(f"{value:.4g}" if isinstance(value, float) else value)
