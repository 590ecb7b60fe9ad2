from vibecalc.api import accuracy as accuracy
from vibecalc.api import check as check
from vibecalc.api import diff as diff
from vibecalc.api import merge as merge
from vibecalc.api import plot as plot
from vibecalc.api import read as read
from vibecalc.api import report as report
from vibecalc.api import run as run
from vibecalc.api import sweep as sweep
from vibecalc.api import verify as verify
from vibecalc.api import write as write
from vibecalc.core.results.record import Axis as Axis
from vibecalc.core.results.record import Quantity as Quantity
from vibecalc.core.results.record import Result as Result
from vibecalc.errors import CaseError as CaseError
from vibecalc.errors import MissingQuantity as MissingQuantity
from vibecalc.errors import NumericalFailure as NumericalFailure
from vibecalc.errors import Problem as Problem
from vibecalc.errors import ResultError as ResultError
from vibecalc.errors import UnitError as UnitError
from vibecalc.errors import UsageError as UsageError
from vibecalc.errors import VibecalcError as VibecalcError

__version__: str
