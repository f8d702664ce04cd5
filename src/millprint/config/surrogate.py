"""Settings of the surrogate stage (thesis chapter 6 and appendix A)."""

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, ValidationError, field_validator, model_validator

from millprint.config.section import Count, Name, NonNegative, Positive, Section, Seed

Value = bool | int | float | str | None
# Snapshots of a case that gives first states, after the start: single steps are measured on them [s].
FIRST_STATES_S = 0.1


class SnapshotConfig(Section):
    """The simulations that train the network. Every snapshot of a case before `train_until_s` is used."""

    cases: list[str] = Field(min_length=1)
    """DEM cases with snapshots, as MILL/CONTACT/NAME"""
    train_until_s: Positive
    """training uses the snapshots up to this time since the start of motion [s]"""
    validation_until_s: Positive
    """the validation loss uses the snapshots from train_until_s up to this time [s]"""

    @model_validator(mode="after")
    def _validation_follows(self) -> "SnapshotConfig":
        if self.validation_until_s <= self.train_until_s:
            raise ValueError(
                f"validation_until_s = {self.validation_until_s:g}: must exceed train_until_s = {self.train_until_s:g}"
            )
        return self


class GraphConfig(Section):
    """Input and target of the network (thesis Table 6.2)."""

    window: Count = 7
    """snapshots of history in the node features, tau + 1 in Eq. 6.19 [-]"""
    acceleration: Literal["finite_difference", "net_force"] = "finite_difference"
    """target: (v[n+1] - v[n]) / dt, or the net force of the instant over the mass"""


class EdgeConfig(Section):
    """Edges between balls, and between balls and wall (thesis Sec. 6.2.2)."""

    training: Literal["contacts", "thresholds"] = "contacts"
    """edges while training: the contacts that the DEM reports, or the thresholds of the roll-out"""
    wall_threshold_m: float = Field(lt=0)
    """phi_pw: a ball with a larger signed distance gets an edge to the wall [m]"""
    ball_threshold_m: Positive
    """r_c: two balls nearer than this get an edge [m]"""
    ball_threshold_reading: Literal["surface_gap", "centre_distance"] = "surface_gap"
    """what r_c bounds: the gap between two surfaces, or the distance of two centres (as printed)"""


class NetworkConfig(Section):
    """Size of the network (thesis Table 6.3)."""

    width: Count = 256
    """neurons of each hidden layer and of the embeddings [-]"""
    mlp_layers: Annotated[int, Field(ge=2, le=100_000)] = 4
    """linear layers of each multi-layer perceptron [-]"""
    interaction_layers: Count = 1
    """rounds of message passing L_p [-]"""


class TrainingConfig(Section):
    """Loss, optimiser and budget (thesis Eqs 6.28 to 6.30 and Sec. 6.2.2)."""

    # Threshold delta of the Huber loss, Eq. 6.30, and alpha, the weight of the acceleration loss, Eq. 6.28 [-].
    huber_delta: ClassVar[float] = 2.0
    acceleration_weight: ClassVar[float] = 3.0
    dissipation_weight: NonNegative = 1.0
    """weight of the dissipation loss, 1 in Eq. 6.28 [-]"""
    velocity_noise: NonNegative = 0.005
    """standard deviation of noise on normalised velocities [-]"""
    epochs: Count = 40
    """epochs over which the learning rate decays [-]"""
    snapshots_per_epoch: Count = 4500
    """snapshots drawn in an epoch; all of them if there are fewer [-]"""
    batch_size: Count = 32
    """snapshots in a batch [-]"""
    learning_rate: Positive = 1e-3
    """learning rate of Adam at the first step [-]"""
    final_learning_rate: Positive = 1e-5
    """learning rate of Adam at the last step, reached exponentially [-]"""
    wall_time_max_s: Positive = 7200.0
    """training stops here even if epochs are left [s]"""
    threads: Count = 1
    """threads of the job, as far as there are cores [-]"""
    checkpoint_every_s: Positive = 30.0
    """time between checkpoints, from which a killed job continues [s]"""
    validation_snapshots: Count = 512
    """snapshots in the validation loss [-]"""
    seed: Seed = 0
    """seed of the weights, the order of snapshots and the noise"""


class RollOutConfig(Section):
    """The recursive stage (thesis Sec. 6.2.2)."""

    snap_back_m: Annotated[float, Field(lt=0)] | None
    """phi_sb: a ball with a larger signed distance is moved back to phi_sb; null: never [m]"""
    length_s: Positive = 15.0
    """physical time of a roll-out [s]"""
    # Time between the stored states [s].
    frame_interval_s: ClassVar[float] = 0.001


class ScenarioConfig(Section):
    """A motion and a geometry for roll-outs of the surrogate."""

    case: str
    """DEM case that gives the first states, as MILL/CONTACT/NAME, with snapshots as far apart as those of the training;
    also the truth, if `truth` is left out
    """
    truth: str | None = None
    """the same run at and after the first start, with more time"""
    twin: str | None = None
    """the truth with a disturbance at the first start: how fast two DEM runs diverge"""
    other_seed: str
    """the same case with another seed: how much two DEM runs differ"""
    long_step: str | None = None
    """the same case with a longer time step: a faster simulation without learning"""
    original: str | None = None
    """DEM case of the unmodified geometry, which the thesis compares with in Fig. 6.17"""
    driven: str | None = None
    """for a test of a jar at rest: a DEM case in motion, whose dissipation is the reference"""
    starts_s: list[NonNegative] = Field(min_length=1)
    """start times of the roll-outs, computed as one batch [s]"""
    length_s: Positive | None = None
    """longest roll-out of this test [s]"""

    def runs(self) -> dict[str, str]:
        """The reference cases of a roll-out, by their role."""
        named = {"dem": self.truth or self.case, "other_seed": self.other_seed}
        further = {name: getattr(self, name) for name in ("twin", "long_step", "original", "driven")}
        return named | {name: case for name, case in further.items() if case}


class TimingConfig(Section):
    """Timing of roll-outs, and of our DEM in the same job."""

    cases: list[str] = Field(min_length=1)
    """DEM cases with snapshots to start from, as MILL/CONTACT/NAME"""
    # Start time of the timed roll-outs [s].
    start_s: ClassVar[float] = 0.2
    steps: Count = 10_000
    """timed steps, after as many steps to warm up, at most 50 [-]"""
    batches: list[Count] = Field([1, 32], min_length=1)
    """numbers of trajectories in a batch [-]"""
    dem_s: Positive = 1.0
    """time of motion over which our DEM is timed [s]"""


class VariantConfig(Section):
    """A surrogate: its changes to the sections of the same names, key by key."""

    weights_of: Name | None = None
    """variant (or, for an ablation, ablation) whose weights are rolled out; its own if left out"""
    graph: dict[str, Value] = Field({})
    """keys of `graph` to override"""
    edges: dict[str, Value] = Field({})
    """keys of `edges` to override"""
    network: dict[str, Value] = Field({})
    """keys of `network` to override"""
    training: dict[str, Value] = Field({})
    """keys of `training` to override"""
    rollout: dict[str, Value] = Field({})
    """keys of `rollout` to override"""


class Recipe(Section):
    """Everything except the data that the weights depend on."""

    graph: GraphConfig
    network: NetworkConfig
    training: TrainingConfig
    edges: EdgeConfig | None = None
    """thresholds; None if DEM contacts are the edges"""


class Variant(Section):
    """A variant with all of its settings."""

    graph: GraphConfig
    edges: EdgeConfig
    network: NetworkConfig
    training: TrainingConfig
    rollout: RollOutConfig

    @model_validator(mode="after")
    def _thresholds_are_ordered(self) -> "Variant":
        low, high = self.edges.wall_threshold_m, self.rollout.snap_back_m
        if high is not None and high <= low:
            raise ValueError(f"rollout.snap_back_m = {high:g}: must exceed edges.wall_threshold_m = {low:g}")
        return self

    def recipe(self) -> Recipe:
        """The recipe of the weights. It has thresholds only if training uses them."""
        edges = self.edges if self.edges.training == "thresholds" else None
        return Recipe(graph=self.graph, network=self.network, training=self.training, edges=edges)


class SurrogateConfig(Section):
    """Settings of the surrogate stage."""

    snapshots: SnapshotConfig
    graph: GraphConfig = GraphConfig()
    edges: EdgeConfig
    network: NetworkConfig = NetworkConfig()
    training: TrainingConfig = TrainingConfig()
    rollout: RollOutConfig
    variants: dict[Name, VariantConfig] = Field(min_length=1)
    """surrogates that `all` trains, by name; null leaves one out"""
    trainings: Count = 5
    """trainings of each variant, with one seed after the other; the first is shown, and all give its spread [-]"""
    ablations: dict[Name, VariantConfig] = Field({})
    """surrogates of the target `ablations`, by name"""
    ablation_budget: VariantConfig = Field(default_factory=VariantConfig)
    """overrides for every ablation, below its own"""
    tests: dict[Name, ScenarioConfig] = Field(min_length=1)
    """motions and geometries to roll out, by name; null leaves one out"""
    # The test on the motion of the training; ablations and timings use it.
    trained_test: ClassVar[str] = "trained"
    timing: TimingConfig

    @field_validator("tests", "variants", "ablations", mode="before")
    @classmethod
    def _without_nulls(cls, content: Any) -> Any:
        # A file on top of another leaves one of its entries out by `name: null`.
        if not isinstance(content, dict):
            return content
        return {name: value for name, value in content.items() if value is not None}

    @model_validator(mode="after")
    def _every_variant_holds(self) -> "SurrogateConfig":
        both = sorted(set(self.variants) & set(self.ablations))
        if both:
            raise ValueError(f"ablations.{both[0]}: is also a variant; a name can stand for one surrogate only")
        if self.trained_test not in self.tests:
            raise ValueError(f"trained_test = {self.trained_test!r}: is not among tests: {', '.join(self.tests)}")
        for name, base in self.trained_again.items():
            if name in self.variants or name in self.ablations:
                raise ValueError(f"variants.{name}: is the name of a further training of {base[0]}")
        for name in [*self.variants, *self.ablations]:
            source = self.weights_of(name)
            # A variant with the weights of an ablation would make `all` run appendix A.
            known = self.variants | (self.ablations if name in self.ablations else {})
            if source not in known:
                raise ValueError(f"{name}.weights_of = {source!r}: unknown; known: {', '.join(known)}")
            if self.weights_of(source) != source:
                raise ValueError(f"{name}.weights_of = {source!r}: has no weights of its own")
            for section in ("graph", "network"):
                if getattr(self.variant(name), section) != getattr(self.variant(source), section):
                    raise ValueError(f"{name}.weights_of = {source!r}: those have another {section}")
        return self

    def variant(self, name: str) -> Variant:
        """The sections of a variant or ablation with its overrides; raises ValueError for an invalid override.

        A further training has the next seed.
        """
        base, number = self.training_of(name)
        layers = [self.ablation_budget, self.ablations[base]] if base in self.ablations else [self.variants[base]]
        content: dict[str, dict[str, Any]] = {}
        for section in Variant.model_fields:
            content[section] = getattr(self, section).model_dump()
            for layer in layers:
                content[section].update(getattr(layer, section))
        content["training"]["seed"] += number - 1
        try:
            return Variant.model_validate(content)
        except ValidationError as error:
            fault = error.errors()[0]
            key = ".".join(str(step) for step in fault["loc"])
            message = fault["msg"].removeprefix("Value error, ")
            raise ValueError(f"{name}.{key} = {fault['input']!r}: {message}" if key else f"{name}: {message}") from None

    @property
    def every(self) -> dict[str, VariantConfig]:
        """The variants, then the ablations."""
        return self.variants | self.ablations

    @property
    def trained_again(self) -> dict[str, tuple[str, int]]:
        """Further trainings by name: the variant (or an ablation that uses its weights) and the number of the training.

        An ablation that is trained itself is trained once.
        """
        bases = [*self.variants, *(name for name, own in self.ablations.items() if own.weights_of in self.variants)]
        numbers = range(2, self.trainings + 1)
        return {f"{base}_training{number}": (base, number) for base in bases for number in numbers}

    def training_of(self, name: str) -> tuple[str, int]:
        """The variant or ablation that a name stands for, and which of its trainings; 1 is the first."""
        return self.trained_again.get(name, (name, 1))

    def trainings_of(self, base: str) -> list[str]:
        """Names of all trainings of a variant or ablation, its own first."""
        return [base, *(name for name, (of, _) in self.trained_again.items() if of == base)]

    def weights_of(self, name: str) -> str:
        """The variant whose weights `name` is rolled out with."""
        base, number = self.training_of(name)
        source = self.every[base].weights_of or base
        return source if number == 1 else f"{source}_training{number}"

    def rollout_of(self, name: str, test: str) -> RollOutConfig:
        """The roll-out settings of a variant in a test; the shorter of both lengths holds."""
        settings, longest = self.variant(name).rollout, self.tests[test].length_s
        if longest is None or longest >= settings.length_s:
            return settings
        return settings.model_copy(update={"length_s": longest})

    def simulated_cases(self) -> dict[str, tuple[float, float]]:
        """Every DEM case that the stage reads, with the time of motion from and to which it needs snapshots [s]."""
        needed: dict[str, tuple[float, float]] = {}

        def add(case: str, from_s: float, until_s: float) -> None:
            low, high = needed.get(case, (from_s, until_s))
            needed[case] = min(low, from_s), max(high, until_s)

        for case in self.snapshots.cases:
            add(case, 0.0, self.snapshots.validation_until_s)
        for name, test in self.tests.items():
            names = [*self.variants, *(self.ablations if name == self.trained_test else [])]
            longest = max(self.rollout_of(variant, name).length_s for variant in names)
            add(test.case, min(test.starts_s), max(test.starts_s) + FIRST_STATES_S)
            for role, case in test.runs().items():
                # Of the jar in motion only the mean power is taken.
                if role == "driven":
                    add(case, math.inf, 0.0)
                else:
                    add(case, min(test.starts_s), max(test.starts_s) + longest)
        for case in self.timing.cases:
            add(case, self.timing.start_s, self.timing.start_s + FIRST_STATES_S)
        return needed
