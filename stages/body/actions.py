"""What people do in a motion: labels from an index or from names, and the broad actions that CLOTH3D counts.

The paper groups the labels of the CMU database, which are free text, into 24 actions and "others" (CLOTH3D, table of
statistics per action label). The words that make a group are this project's; the paper doesn't give its own.
"""

import re
from collections import Counter
from collections.abc import Iterable

from stages.body.clips import CLIPS

OTHERS = "Others"

WORDS: dict[str, str] = {
    "Swim": "swim swimming backstroke breaststroke breast stroke freestyle crawl stroke",
    "Animal": "animal monkey bear chicken cat dog elephant snake dinosaur penguin gorilla fish insect praying mantis "
    "tiger dragon mouse rabbit bunny bird prairie lizard horse cow roadrunner mummy quail",
    "Climb": "climb climbs climbing ladder playground stairs stepstool",
    "Yoga": "yoga tai chi asana",
    "Dance": "dance dances dancing ballet salsa charleston waltz pirouette cha indian moonwalk breakdance arabesque "
    "attitude jete tango",
    "Fight": "fight fighting punch punches boxing box karate martial kick kicks sword kendo swordplay strike strikes "
    "bushido knife wrestle",
    "Sports": "basketball soccer football golf baseball tennis dribble dribbling dribbles shoot throw throws pitch "
    "frisbee hockey volleyball ball catch skateboard skating ski bowling badminton",
    "Jump": "jump jumps jumping leap leaps hop hops hopping hopscotch skip skipping bounce",
    "Run": "run runs running jog jogs jogging sprint sprinting",
    "Sing": "sing sings singing song nursery rhyme teapot cockrobin conduct",
    "Story": "story storytelling tell telling recite rehearsal",
    "Exercise": "exercise exercises exercising stretch stretching situp situps pushup pushups calisthenics warm squat "
    "squats bends twist lunge lunges jacks",
    "Balancing": "balance balances balancing beam tightrope",
    "Trick": "trick tricks acrobatics acrobatic cartwheel cartwheels flip flips handstand somersault backflip "
    "handspring tumble roll",
    "Spin": "spin spins spinning twirl whirl turn",
    "Carry": "carry carries carrying lift lifting pick picks picking suitcase box bag load",
    "Wash": "wash washes washing clean cleaning sweep sweeping mop mopping wipe wiping window floor vacuum laundry "
    "scrub",
    "Drink": "drink drinks drinking sip bottle soda",
    "Sit": "sit sits sitting stool chair seat",
    "Interact": "interact interaction handshake shake shakes hands conversation talk talking chat alternating",
    "Wait": "wait waits waiting bus directing traffic signal signals hail",
    "Pose": "pose poses posing range motion tpose static calibration",
    "Walk": "walk walks walking stride strides march marching stroll wander navigate navigating zombie tiptoe limp "
    "sneak stealthily stealthy steps",
    "Stand": "stand stands standing still idle",
}
"""Actions -> words of labels; of the words in a label the first that is known decides."""

_ACTION_OF = {word: action for action, words in reversed(WORDS.items()) for word in words.split()}


def broad_action(label: str) -> str:
    """The broad action of a label such as "walk stealthily" or "basketball_2"; "Others" if no word is known."""
    for word in re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", label).lower()):
        if word in _ACTION_OF:
            return _ACTION_OF[word]
    return OTHERS


def action_of(motion: str) -> str:
    """The action that a motion's name tells: the clip's own, or the file's name without its number."""
    if motion in CLIPS:
        return CLIPS[motion].action
    return motion.rstrip("0123456789_- ") or motion


def count_actions(labels: Iterable[tuple[str, int]]) -> list[tuple[str, int, int]]:
    """How many sequences and frames there are of each broad action.

    Args:
        labels: Label and number of frames of each sequence.

    Returns:
        Action, sequences and frames, most frames first, "Others" last.
    """
    sequences: Counter[str] = Counter()
    frames: Counter[str] = Counter()
    for label, length in labels:
        action = broad_action(label)
        sequences[action] += 1
        frames[action] += length
    order = sorted(sequences, key=lambda action: (action == OTHERS, -frames[action], action))
    return [(action, sequences[action], frames[action]) for action in order]
