"""Settings of the `contact` surrogate: coarse steps in which pairs are solved and their coupling is learned."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.section import Fraction, Name, NonNegative, Positive, Section

Count = Annotated[int, Field(ge=1)]
WIDTH_MAX = 128


class CoarseConfig(Section):
    """The coarse step, and how pairs are solved in it."""

    rayleigh_multiple: Positive = Field(
        default=0.96,
        description="longest coarse step over the Rayleigh time of the balls; the same for all balls, so that all "
        "contacts take as many steps [-]",
    )
    substeps: Count = Field(default=4, description="substeps of each pair's own problem in a coarse step [-]")
    warm_up_s: NonNegative = Field(
        default=0.002,
        description="recorded states before the start that are gone through to know the springs of open contacts [s]",
    )


class TraceConfig(Section):
    """A simulation whose contacts are followed coarse step by coarse step."""

    mill: Name = Field(description="mill")
    contact: Name = Field(description="contact set")
    ball_diameter_mm: Positive = Field(description="ball diameter [mm]")
    fill_ratio: Fraction = Field(description="ball volume over jar volume [-]")
    speed_rpm: NonNegative = Field(description="mill speed [rpm]")
    seed: Annotated[int, Field(ge=0)] = Field(description="seed of the starting positions")
    from_s: NonNegative = Field(default=0.05, description="time of motion from which contacts are followed [s]")
    until_s: Positive = Field(description="and until which [s]")
    every: Count = Field(description="one coarse step in so many is followed [-]")

    @model_validator(mode="after")
    def _there_is_time(self) -> "TraceConfig":
        if self.until_s <= self.from_s:
            raise ValueError(f"until_s = {self.until_s:g}: must exceed from_s = {self.from_s:g}")
        return self


class ValidationConfig(Section):
    """Roll-outs that tell when training is good enough: of the first trace's case, after what is learned from."""

    starts: Count = Field(default=12, description="roll-outs [-]")
    length_s: Positive = Field(default=0.2, description="length of each [s]")
    position_s: Positive = Field(default=0.05, description="time after which positions are compared [s]")


class PredictorConfig(Section):
    """Size of the network that expects what contacts will do."""

    width: Annotated[int, Field(ge=1, le=WIDTH_MAX)] = Field(
        default=24, description="neurons of each of two hidden layers [-]"
    )
    rounds: Count = Field(default=1, description="rounds of messages between contacts of one ball [-]")


class ContactTrainingConfig(Section):
    """Optimiser, budget and early stopping, for each member of the ensemble."""

    epochs: Count = Field(default=24, description="epochs over which the learning rate decays [-]")
    steps_per_epoch: Count = Field(default=200, description="batches in an epoch [-]")
    batch_size: Count = Field(default=48, description="states in a batch, each with all its contacts [-]")
    learning_rate: Positive = Field(default=4e-3, description="of Adam at the first step [-]")
    final_learning_rate: Positive = Field(
        default=1e-4, description="of Adam at the last step, reached exponentially [-]"
    )
    push_forward_after: Annotated[int, Field(ge=0)] = Field(
        default=14,
        description="epochs after which states that the surrogate itself has reached are learned from too [-]",
    )
    push_forward_steps: Count = Field(
        default=20, description="own coarse steps from a state of the DEM to such a state [-]"
    )
    push_forward_states: Count = Field(
        default=1500, description="such states, each followed for one coarse step by the DEM [-]"
    )
    patience: Count = Field(default=8, description="epochs without a better roll-out after which training stops [-]")
    wall_time_max_s: Positive = Field(
        default=240.0, description="training of a member stops here even if epochs are left [s]"
    )
    checkpoint_every_s: Positive = Field(
        default=30.0, description="time between checkpoints, from which a killed job goes on [s]"
    )
    threads: Count = Field(default=1, description="threads of the job; small networks run fastest on one [-]")
    seed: Annotated[int, Field(ge=0)] = Field(default=0, description="of the first member; the others follow")


class ContactSurrogateConfig(Section):
    """Everything of the surrogate that learns contacts."""

    coarse: CoarseConfig = CoarseConfig()
    traces: list[TraceConfig] = Field(min_length=1, description="simulations to learn from; never of a test's mill")
    judge: ValidationConfig = ValidationConfig()
    network: PredictorConfig = PredictorConfig()
    training: ContactTrainingConfig = ContactTrainingConfig()
    members: Count = Field(default=3, description="networks in the ensemble; the first one is rolled out [-]")


class ContactRecipe(Section):
    """What the weights carry with them: all that a roll-out needs to know."""

    coarse: CoarseConfig
    network: PredictorConfig
    training: ContactTrainingConfig
    members: Count = Field(description="networks in the ensemble [-]")
