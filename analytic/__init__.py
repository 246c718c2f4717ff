"""The analytic elastodynamic model of R-P-S parallel manipulators: numpy and scipy only."""

__version__ = "0.1.0"

from analytic.condensed import condensed_frequencies
from analytic.condensed_model import Condensed
from analytic.continuum import Continuum
from analytic.errors import InputError, NotCertifiedError
from analytic.joint import Freedom, Joint
from analytic.kinematics import Limbs, limbs_at, position
from analytic.mechanism import Limb, Mechanism
from analytic.model import Info, Model
from analytic.modes import STATIONS, Modes
from analytic.multipliers import Multipliers
from analytic.platform import Platform
from analytic.plausible import UnlikelyWarning, unlikely
from analytic.pose import Pose
from analytic.regular_workspace import RegularWorkspace, regular_workspace
from analytic.rod import Body, Link, Material, Rod, Section
from analytic.sensitivity import frequency_sensitivities
from analytic.stiffness import Stiffness, stiffness
from analytic.substructure import Substructure
from analytic.theory import Theory
from analytic.workspace import Limits, reachable

__all__ = [
    "STATIONS",
    "Body",
    "Condensed",
    "Continuum",
    "Freedom",
    "Info",
    "InputError",
    "Joint",
    "Limb",
    "Limbs",
    "Limits",
    "Link",
    "Material",
    "Mechanism",
    "Model",
    "Modes",
    "Multipliers",
    "NotCertifiedError",
    "Platform",
    "Pose",
    "RegularWorkspace",
    "Rod",
    "Section",
    "Stiffness",
    "Substructure",
    "Theory",
    "UnlikelyWarning",
    "condensed_frequencies",
    "frequency_sensitivities",
    "limbs_at",
    "position",
    "reachable",
    "regular_workspace",
    "stiffness",
    "unlikely",
]
