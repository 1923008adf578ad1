"""What comes out of a panel's watch over itself."""

from dataclasses import dataclass, field

from analysis.checked_fields import check_finite, check_range
from analysis.health.refined import RefinedChange


@dataclass(frozen=True)
class HealthDate:
    """One date.

    Attributes
    ----------
    date : str
    label : float or None
        Temperature as recorded, degrees Celsius; None where no thermometer was.
    temperature, sigma : float
        As the panel itself says, degrees Celsius, and its standard deviation, K.
    misfit : float
        Chi2 per degree of freedom, of the healthy panel.
    z : float
        Largest of all candidates and spans, in standard deviations.
    strongest : str
        Of which candidate.
    span : int
        Of how many last dates.
    alarm : bool
    skipped : str
        Why the date could not be judged; empty where it was.
    """

    date: str
    label: float | None
    temperature: float = 0.0
    sigma: float = 0.0
    misfit: float = 0.0
    z: float = 0.0
    strongest: str = ""
    span: int = 0
    alarm: bool = False
    skipped: str = ""

    def __post_init__(self) -> None:
        check_finite(self, "temperature", "z", *(() if self.label is None else ("label",)))
        check_range(self, 0.0, float("inf"), "sigma", "misfit")


@dataclass(frozen=True)
class NamedChange:
    """What has changed.

    Attributes
    ----------
    family : str
        Of `analysis.health.candidates.WORDS`; ``unknown`` where no candidate explains it.
    probability : float
        Of the family, among all.
    probabilities : tuple of (str, float)
        Of every family, the most likely first.
    change : RefinedChange or None
        None where it is unknown.
    since : str
        First of the dates that it rests on.
    span : int
        Number of these dates.
    trend : tuple of (float, float)
        Amplitude on every judged date by that date alone, and its standard deviation.
    also : tuple of RefinedChange
        The same at other places that are nearly as likely: patches that lie symmetrically cannot tell them apart.
    """

    family: str
    probability: float
    probabilities: tuple[tuple[str, float], ...]
    change: RefinedChange | None
    since: str
    span: int
    trend: tuple[tuple[float, float], ...] = field(default=(), repr=False)
    also: tuple[RefinedChange, ...] = ()

    def __post_init__(self) -> None:
        check_range(self, 0.0, 1.0, "probability")


@dataclass(frozen=True)
class HealthReport:
    """All dates, and what has changed up to the last.

    Attributes
    ----------
    rate : float
        False alarms per date, at most.
    limit, misfit_limit : float
        Of z, and of the misfit on one date.
    dates : tuple of HealthDate
        In order.
    found : NamedChange or None
        None where the last date gives no alarm.
    baseline_misfit : float
        Largest chi2 per degree of freedom of a temperature of the baseline, predicted from the others.
    order : int
        Of the polynomial that carries the twin's error over temperature.
    """

    rate: float
    limit: float
    misfit_limit: float
    dates: tuple[HealthDate, ...]
    found: NamedChange | None
    baseline_misfit: float
    order: int

    def __post_init__(self) -> None:
        check_range(self, 0.0, 1.0, "rate", above=True)
        check_range(self, 0.0, float("inf"), "limit", "misfit_limit", "baseline_misfit", above=True)

    @property
    def judged(self) -> tuple[HealthDate, ...]:
        """Dates that could be judged."""
        return tuple(one for one in self.dates if not one.skipped)

    @property
    def first_alarm(self) -> HealthDate | None:
        """The first date with an alarm; None without one."""
        return next((one for one in self.dates if one.alarm), None)
