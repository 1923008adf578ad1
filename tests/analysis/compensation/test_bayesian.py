import numpy as np
import pytest
import torch

from analysis.compensation.bayesian import TrainingProblem, determined, judge, parameter_count, reestimate, train
from analysis.compensation.linearised import Weights, linearise


def tensor(array):
    return torch.as_tensor(np.asarray(array, dtype=float))


def waves(inputs, outputs):
    m = np.arange(outputs)
    return np.sin(np.outer(inputs, 1.0 + 0.5 * m) + 0.3 * m) + 0.2 * np.outer(inputs**2, np.cos(m))


@pytest.mark.parametrize(("nodes", "outputs", "epochs", "warm"), [(3, 7, 40, False), (5, 14, 40, True)])
def test_training_equals_the_dense_algorithm_to_nine_digits(dense, rng, nodes, outputs, epochs, warm):
    """Started at random, and from a fit of the output layer, where the rotation leaves rank-many outputs.

    Forty epochs multiply rounding, which differs between processors: 1.02e-10 was seen on one, less on others.
    """
    inputs = np.linspace(-1.0, 1.0, 9)
    targets = waves(inputs, outputs)
    slope, bias = 2.0 * rng.normal(size=nodes), rng.normal(size=nodes)
    output = rng.uniform(-1.0, 1.0, size=(nodes + 1, outputs))
    if warm:
        features = np.column_stack([np.tanh(np.outer(inputs, slope) + bias), np.ones(9)])
        output = np.linalg.lstsq(features, targets)[0]
    exact = dense.train_dense(inputs, targets, slope, bias, output, epochs)

    axes = np.linalg.svd(targets if warm else np.concatenate([targets, output]), full_matrices=False)[2]
    assert len(axes) <= 9
    problem = TrainingProblem(tensor(inputs), tensor(targets @ axes.T)[None], tensor(np.ones((1, 9))), outputs)
    start = Weights(tensor(slope)[None], tensor(bias)[None], tensor(output @ axes.T)[None])
    fit = train(problem, start, epochs, tolerance=0.0)

    assert fit.evidence.alpha.item() == pytest.approx(exact.alpha, rel=1e-9)
    assert fit.evidence.beta.item() == pytest.approx(exact.beta, rel=1e-9)
    found = np.concatenate(
        [fit.weights.slope[0].numpy(), fit.weights.bias[0].numpy(), (fit.weights.output[0].numpy() @ axes).ravel()]
    )
    np.testing.assert_allclose(found, exact.parameters, rtol=0, atol=1e-9 * np.abs(exact.parameters).max())


def test_at_the_end_alpha_and_beta_are_mackay_s_fixed_point(rng):
    inputs = np.linspace(-1.0, 1.0, 15)
    targets = waves(inputs, 6) + 0.05 * rng.normal(size=(15, 6))
    problem = TrainingProblem(tensor(inputs), tensor(targets)[None], tensor(np.ones((1, 15))), 6)
    start = Weights(*(tensor(rng.normal(size=s)) for s in ((1, 4), (1, 4), (1, 5, 6))))
    fit = train(problem, start, 2000, tolerance=1e-9)
    at = linearise(fit.weights, problem.inputs, problem.targets, problem.used)
    gamma = fit.evidence.gamma
    assert (2.0 * fit.evidence.alpha * fit.weights.squares() / gamma).item() == pytest.approx(1.0, abs=1e-6)
    assert (2.0 * fit.evidence.beta * (at.error**2).sum() / (90.0 - gamma)).item() == pytest.approx(1.0, abs=1e-6)
    # The noise put in comes back as 1/(2β).
    assert (0.5 / fit.evidence.beta).sqrt().item() == pytest.approx(0.05, rel=0.3)


def saturated(rng, outputs):
    """Hidden nodes far into saturation: steps between the samples, so the outputs are linear in the parameters."""
    inputs = np.linspace(-1.0, 1.0, 12)
    slope = np.full(3, 1e4)
    bends = np.array([-0.55, 0.1, 0.6])
    features = np.column_stack([np.sign(inputs[:, None] - bends), np.ones(12)])
    targets = features @ rng.normal(size=(4, outputs)) + 0.1 * rng.normal(size=(12, outputs))
    start = Weights(tensor(slope)[None], tensor(-slope * bends)[None], tensor(np.zeros((4, outputs)) + 0.1)[None])
    problem = TrainingProblem(tensor(inputs), tensor(targets)[None], tensor(np.ones((1, 12))), outputs)
    return features, targets, problem, start


def test_gamma_of_a_linear_model_is_the_sum_over_its_eigenvalues(rng):
    features, _, problem, start = saturated(rng, 5)
    alpha, beta = tensor([0.7]), tensor([3.0])
    at = linearise(start, problem.inputs, problem.targets, problem.used)
    values = np.linalg.eigvalsh(features.T @ features)
    exact = 5 * np.sum(3.0 * values / (3.0 * values + 0.7))
    assert determined(problem, start, at, alpha, beta).item() == pytest.approx(exact, rel=1e-10)
    new_alpha, new_beta = reestimate(problem, start, at, alpha, beta)
    assert new_alpha.item() == pytest.approx(exact / (2.0 * start.squares().item()), rel=1e-10)
    assert new_beta.item() == pytest.approx((60 - exact) / (2.0 * (at.error**2).sum().item()), rel=1e-10)


def test_the_evidence_of_a_linear_model_is_its_marginal_likelihood(rng):
    """p(t) of Bayesian linear regression is Gaussian with covariance I/(2β) + ZZᵀ/(2α): no approximation."""
    features, targets, problem, start = saturated(rng, 2)
    alpha, beta = 0.7, 3.0
    best = np.linalg.solve(beta * features.T @ features + alpha * np.eye(4), beta * features.T @ targets)
    at_best = Weights(start.slope, start.bias, tensor(best)[None])
    at = linearise(at_best, problem.inputs, problem.targets, problem.used)
    found = judge(problem, at_best, at, tensor([alpha]), tensor([beta])).log_evidence.item()
    covariance = np.eye(12) / (2 * beta) + features @ features.T / (2 * alpha)
    exact = (
        -0.5 * np.sum(targets * np.linalg.solve(covariance, targets))
        - 0.5 * 2 * np.linalg.slogdet(2 * np.pi * covariance)[1]
    )
    # The hidden parameters, which the data do not touch, keep their prior: -α w² and nothing more.
    prior = -alpha * (start.slope**2 + start.bias**2).sum().item()
    assert found - prior == pytest.approx(exact, rel=1e-9)


def test_left_out_samples_change_nothing(rng):
    inputs = np.linspace(-1.0, 1.0, 9)
    targets = waves(inputs, 5)
    used = np.ones((1, 9))
    used[0, 4] = 0.0
    start = [rng.normal(size=s) for s in ((1, 3), (1, 3), (1, 4, 5))]

    def trained(samples):
        problem = TrainingProblem(tensor(inputs), tensor(samples)[None], tensor(used), 5)
        return train(problem, Weights(*map(tensor, start)), 50, tolerance=0.0)

    spoiled = targets.copy()
    spoiled[4] = 1e3
    one, two = trained(targets), trained(spoiled)
    torch.testing.assert_close(one.weights.output, two.weights.output, rtol=0, atol=0)
    short = TrainingProblem(
        tensor(np.delete(inputs, 4)), tensor(np.delete(targets, 4, 0))[None], tensor(np.ones((1, 8))), 5
    )
    three = train(short, Weights(*map(tensor, start)), 50, tolerance=0.0)
    torch.testing.assert_close(one.weights.output, three.weights.output, rtol=1e-8, atol=1e-8)


def test_a_network_trains_the_same_alone_and_in_company(rng):
    inputs = np.linspace(-1.0, 1.0, 9)
    targets = np.stack([waves(inputs, 5), 3.0 * waves(inputs, 5)[:, ::-1]])
    start = [rng.normal(size=s) for s in ((2, 3), (2, 3), (2, 4, 5))]
    both = train(
        TrainingProblem(tensor(inputs), tensor(targets), tensor(np.ones((2, 9))), 5),
        Weights(*map(tensor, start)),
        60,
    )
    for b in range(2):
        problem = TrainingProblem(tensor(inputs), tensor(targets[b : b + 1]), tensor(np.ones((1, 9))), 5)
        alone = train(problem, Weights(*(tensor(s[b : b + 1]) for s in start)), 60)
        assert alone.epochs.item() == both.epochs[b].item()
        torch.testing.assert_close(alone.weights.slope[0], both.weights.slope[b], rtol=1e-6, atol=1e-8)


def test_tensors_of_torch_train_as_arrays_of_numpy_do(rng):
    """What `--device` asks for runs the same lines; only rounding differs."""
    inputs, targets = np.linspace(-1.0, 1.0, 9), np.stack([waves(np.linspace(-1.0, 1.0, 9), 5)] * 3)
    start = [rng.normal(size=s) for s in ((3, 4), (3, 4), (3, 5, 5))]

    def trained(kind):
        problem = TrainingProblem(kind(inputs), kind(targets), kind(np.ones((3, 9))), 5)
        return train(problem, Weights(*map(kind, start)), 40)

    one, other = trained(np.asarray), trained(tensor)
    assert isinstance(one.weights.output, np.ndarray)
    assert isinstance(other.weights.output, torch.Tensor)
    np.testing.assert_allclose(one.weights.output, other.weights.output.numpy(), rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(one.evidence.log_evidence, other.evidence.log_evidence.numpy(), rtol=1e-9)
    np.testing.assert_array_equal(one.epochs, other.epochs.numpy())


def test_networks_that_have_ended_keep_their_place_and_their_weights(rng):
    """The batch shrinks as its members end; each is what it is alone, to the last bit in numpy."""
    inputs = np.linspace(-1.0, 1.0, 9)
    targets = waves(inputs, 5) + 0.1 * rng.normal(size=(3, 9, 5))
    start = [rng.normal(size=s) for s in ((3, 2), (3, 2), (3, 3, 5))]

    def trained(which):
        problem = TrainingProblem(inputs, targets[which], np.ones((len(targets[which]), 9)), 5)
        return train(problem, Weights(*(s[which] for s in start)), 2000)

    together = trained(slice(None))
    assert len(set(together.epochs.tolist())) == 3
    for b in range(3):
        alone = trained(slice(b, b + 1))
        assert alone.epochs[0] == together.epochs[b]
        np.testing.assert_array_equal(alone.weights.output[0], together.weights.output[b])
        np.testing.assert_array_equal(alone.evidence.gamma[0], together.evidence.gamma[b])


def test_the_paper_s_network_has_5652_parameters():
    weights = Weights(*(torch.zeros(s, dtype=torch.float64) for s in ((1, 10), (1, 10), (1, 11, 13))))
    assert parameter_count(weights, 512) == 5652
