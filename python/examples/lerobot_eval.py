"""A policy in LeRobot's own evaluation: lerobot_eval.py

Needs the packages lerobot (0.4.4) and openbench. The policy drives in a circle; one of LeRobot's
gets the same observations. Prints LeRobot's summary.
"""

from __future__ import annotations

from typing import Any

import torch
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.scripts.lerobot_eval import eval_policy

from openbench.lerobot import LeRobotVectorEnv


class Circle(PreTrainedPolicy):
    config_class = ACTConfig
    name = "circle"

    def __init__(self) -> None:
        super().__init__(ACTConfig(device="cpu", push_to_hub=False))

    def reset(self) -> None:
        pass

    def select_action(self, batch: dict[str, Any], **_: Any) -> torch.Tensor:
        images, state = batch["observation.image"], batch["observation.state"]
        assert images.shape[1:] == (3, 480, 640) and len(batch["task"]) == len(state)
        return torch.tensor([[0.2, 0.3, 0.0]]).repeat(len(state), 1)

    def predict_action_chunk(self, batch: dict[str, Any], **_: Any) -> torch.Tensor:
        return self.select_action(batch)[:, None]

    def forward(self, batch: dict[str, Any]) -> Any:
        raise NotImplementedError

    def get_optim_params(self) -> dict[str, Any]:
        return {}


def same(batch: Any) -> Any:
    """No change before or after the policy."""
    return batch


def main() -> None:
    env = LeRobotVectorEnv(2, "small", time_limit=2.0)
    summary = eval_policy(env, Circle(), same, same, same, same, n_episodes=4, start_seed=5)
    print(summary["aggregated"])


if __name__ == "__main__":
    main()
