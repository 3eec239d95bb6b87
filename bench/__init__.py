"""henkei against its peers: ``python -m bench``.

Peers are optional, and named with their versions. All get the same input; every case runs in a
fresh process with one thread. CPU and wall seconds are the best of some repetitions, memory is the
process's peak. Ratios are of CPU seconds, henkei's by the peer's, so below 1 henkei is faster.
"""
