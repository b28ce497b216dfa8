"""What makes suites harder."""

from __future__ import annotations

import json
from collections.abc import Mapping

#: Levels, as in `{"map": "city"}`, or numbers, as in `{"map.shift_m": 3}`.
Conditions = Mapping[str, str | float | bool]


def written(conditions: Conditions | None) -> list[tuple[str, str]]:
    """Conditions as the command line takes them."""
    pairs = (conditions or {}).items()
    return [(key, value if isinstance(value, str) else json.dumps(value)) for key, value in pairs]
