"""Settings of the `contact` surrogate: coarse steps in which pairs are solved and their coupling is learned."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.section import Count, Fraction, Name, NonNegative, Positive, Section, Seed

WIDTH_MAX = 128


class CoarseConfig(Section):
    """The coarse step, and how pairs are solved in it."""

    rayleigh_multiple: Positive = 0.96
    """longest coarse step over the Rayleigh time of the balls; the same for all balls, so that all contacts take as
    many steps [-]
    """
    substeps: Count = 4
    """substeps in which each pair is solved within a coarse step [-]"""
    warm_up_s: NonNegative = 0.002
    """recorded states before the start that are gone through to know the springs of open contacts [s]"""


class TraceConfig(Section):
    """A simulation whose contacts are recorded at each coarse step."""

    mill: Name
    """mill"""
    contact: Name
    """contact set"""
    ball_diameter_mm: Positive
    """ball diameter [mm]"""
    fill_ratio: Fraction
    """ball volume over jar volume [-]"""
    speed_rpm: NonNegative
    """mill speed [rpm]"""
    seed: Seed
    """seed of the starting positions"""
    from_s: NonNegative = 0.05
    """time of motion at which the recording of contacts begins [s]"""
    until_s: Positive
    """time of motion at which it ends [s]"""
    every: Count
    """every n-th coarse step is recorded [-]"""

    @model_validator(mode="after")
    def _there_is_time(self) -> "TraceConfig":
        if self.until_s <= self.from_s:
            raise ValueError(f"until_s = {self.until_s:g}: must exceed from_s = {self.from_s:g}")
        return self


class ValidationConfig(Section):
    """Roll-outs that show when training is good enough: of the first trace, after the time of the training."""

    starts: Count = 12
    """roll-outs [-]"""
    length_s: Positive = 0.2
    """length of each [s]"""
    position_s: Positive = 0.05
    """positions are compared after this time [s]"""


class PredictorConfig(Section):
    """Size of the network that predicts the forces of contacts."""

    width: Annotated[int, Field(ge=1, le=WIDTH_MAX)] = 24
    """neurons of each of two hidden layers [-]"""
    rounds: Count = 1
    """rounds of messages between contacts of one ball [-]"""


class ContactTrainingConfig(Section):
    """Optimiser, budget and early stopping, for each member of the ensemble."""

    epochs: Count = 24
    """epochs over which the learning rate decays [-]"""
    steps_per_epoch: Count = 200
    """batches in an epoch [-]"""
    batch_size: Count = 48
    """states in a batch, each with all its contacts [-]"""
    learning_rate: Positive = 4e-3
    """learning rate of Adam at the first step [-]"""
    final_learning_rate: Positive = 1e-4
    """learning rate of Adam at the last step, reached exponentially [-]"""
    push_forward_after: Annotated[int, Field(ge=0)] = 14
    """after so many epochs, states that the surrogate itself has reached are trained on too [-]"""
    push_forward_steps: Count = 20
    """coarse steps of the surrogate from a state of the DEM to such a state [-]"""
    push_forward_states: Count = 1500
    """number of such states; the DEM computes one coarse step from each [-]"""
    patience: Count = 8
    """training stops after so many epochs without a better roll-out [-]"""
    wall_time_max_s: Positive = 240.0
    """training of a member stops here even if epochs are left [s]"""
    checkpoint_every_s: Positive = 30.0
    """time between checkpoints, from which a killed job continues [s]"""
    threads: Count = 1
    """threads of the job; small networks run fastest on one [-]"""
    seed: Seed = 0
    """seed of the first member; the others have the next numbers"""


class ContactSurrogateConfig(Section):
    """Settings of the surrogate that learns contacts."""

    coarse: CoarseConfig = CoarseConfig()
    traces: list[TraceConfig] = Field(min_length=1)
    """simulations for training; never in the mill of a test"""
    judge: ValidationConfig = ValidationConfig()
    network: PredictorConfig = PredictorConfig()
    training: ContactTrainingConfig = ContactTrainingConfig()
    members: Count = 3
    """networks in the ensemble; the first one is rolled out [-]"""


class ContactRecipe(Section):
    """Settings in the weights file: all that a roll-out needs."""

    coarse: CoarseConfig
    network: PredictorConfig
    training: ContactTrainingConfig
    members: Count
    """networks in the ensemble [-]"""
