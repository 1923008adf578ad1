"""Every kind of file that is read, and the code that reads it for a verb or a window."""

from tests.fuzz.campaign_readers import CAMPAIGNS
from tests.fuzz.measurement_readers import MEASUREMENTS
from tests.fuzz.reader import Reader
from tests.fuzz.result_readers import RESULTS

READERS: tuple[Reader, ...] = (*CAMPAIGNS, *MEASUREMENTS, *RESULTS)
