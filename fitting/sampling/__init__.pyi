"""Draws from the posterior of a fit."""

from fitting.sampling.chain import Chain as Chain
from fitting.sampling.mcmc import WRITING as WRITING
from fitting.sampling.mcmc import OtherChainError as OtherChainError
from fitting.sampling.mcmc import sample as sample
from fitting.sampling.posterior_function import LogPosterior as LogPosterior
from fitting.sampling.posterior_function import log_posterior as log_posterior
