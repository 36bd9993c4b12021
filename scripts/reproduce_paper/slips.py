"""Misprints of the paper: place, what is printed, what is meant."""
SLIPS = [
    ("(1) against (10), (14)", "theta~ = theta - theta^, x~ = x^ - x", "two signs; here errors are estimate minus truth"),
    ("Table I", "x^: quantized joint space coordinate vector; x~: error on joint space", "operational space, both"),
    (
        "Table I",
        "sigma_x^: variance of the error; Sigma_x~ in R^(p x p): extended state",
        "sigma_x~; Sigma of x-bar (Sigma_x~ in R^(m x m) is another row)",
    ),
    ("Table I", "n", "three quantities: joints, order of the filter, counts per revolution (43); f: two, map and rate"),
    ("(4)", "theta^ has a uniform distribution", "theta~ has"),
    ("(6), (8), (33), (34)", "E(E(...)E(...))", "E((...)(...))"),
    ("(27)", "the mean of the output, sigma^2", "E y~"),
    ("(30)", "y_{k+1} = C x_k + D e_k", "y_k, or (38) does not follow"),
    (
        "(35)",
        "the other terms vanish as the error is zero mean",
        "they vanish as it is white: the state holds earlier errors",
    ),
    ("(42)", "v_RMS = A omega/sqrt(2), omega = 2.5 Hz", "omega = 2 pi 2.5 rad/s (row 27)"),
    (
        "Sec. V-B",
        "above f/2 the cut-off is aliased",
        "real poles do not alias; a bilinear low-pass has no cut-off there (qerr refuses it)",
    ),
    (
        "Sec. VII",
        "to estimate a derivative of degree d, a filter of at least order n",
        "of order n >= d, by Table III",
    ),
    ("App. A.C", "speed in units of the interval over the sample rate, Delta/T", "over the sample period: Delta/T = Delta f"),
    ("(55)", "R1 is inside R1 +- 0.135 Delta/sqrt(A/Delta)", "|R1| <= 0.135 Delta/sqrt(A/Delta) (row 23)"),
]
