"""Search: which explanation of the gap is accepted.

In: ``Evidence``, the nominal ``Trial``, and a ``library.Library`` of effects that may be named. Out: a
``search.SearchResult``: the best explanation, what else was tried, and the rivals of each of its effects.

* ``candidates``, ``ground_candidates``: on which joints an effect of the ``library`` is tried, and from
  where. What is special about an effect it says itself.
* ``rounds``: every candidate is fitted roughly, the best are cross-validated and ranked.
* ``acceptance``: what an effect must gain on held-out gaits. ``search`` adds effects one by one and prunes.
* ``rivals``: other effects in the place of each one found. ``groups``: those that the data cannot tell from it.
* ``random_loss``: set-points lost at random, which show in the scatter.
"""
