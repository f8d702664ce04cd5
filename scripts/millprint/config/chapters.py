"""What the chapters of the thesis need of a configuration, none of it left out."""

from millprint.config.calibration import CalibrationConfig
from millprint.config.data import DataConfig
from millprint.config.doe import DoeConfig
from millprint.config.fingerprint import InverseConfig, MapsConfig
from millprint.config.partition import PartitionConfig
from millprint.config.section import Section
from millprint.config.surrogate import SurrogateConfig
from millprint.config.yields import YieldConfig


class ChapterSections(Section):
    """The sections of a configuration that has chapters; `cycle_fill_ratio`, `maps`, `inverse` are of `fingerprint`."""

    data: DataConfig
    doe: DoeConfig
    calibration: CalibrationConfig
    cycle_fill_ratio: float
    maps: MapsConfig
    inverse: InverseConfig
    partition: PartitionConfig
    yields: YieldConfig
    surrogate: SurrogateConfig
