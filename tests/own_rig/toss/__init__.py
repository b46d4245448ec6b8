"""A seed thrown upwards: how fast was it thrown?"""

from benchtwin.rigs.toss.keys import Toss

from benchtwin.bench.rig import Rig

RIG = Rig(
    name="toss",
    what="a seed is thrown upwards",
    plural="tosses",
    keys=Toss,
    main=("launch_speed", "m/s"),
    printed=(("launch_speed", "flight_time"),),
    readings={"flight_time_s": ("flight_time", "s")},
    wanted=(("camera", "mm_per_px"),),
    asked=(("[toss] speed_m_s", "how fast was it thrown?"),),
    observe=".measure:observe",
    setup=".simulate:SETUP",
)
