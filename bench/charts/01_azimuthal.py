"""What the azimuthal part of a lobe costs against how far it is from the traced ellipse: rows of every learner, quadrature,
other models. bench/accuracy/azimuthal_rivals.cpp says what exactly is timed and compared."""
import charts

TITLE = "Azimuthal part: error against cost"
DOMAINS = {"whole": "sigma 1 to 45 degrees, e .5 to 1", "hard": "sigma 1 to 10 degrees, e .7 to 1"}
LEARNERS = ("eager", "ais", "table", "em", "appendix", "appendix-literal", "sketch")  # the last is drawn on top
CIRCULAR = ("deon2011", "deon2022", "chiang2016", "ou2012", "marschner2003", "pekelis2015")
QUANTILES = ("p50", "p90", "p99", "max")
LEFT_OUT = {"fiber3d": "has no azimuthal density, it can only be sampled",
            "GLINT by itself": "is part of TRT here, as in a fiber that does not split it off",
            "corrected": "is a row or a trace by chance: see the charts of pictures"}


def measure(run):
    rows, repetitions, least = (40, 3, 0.005) if run.quick else (256, 5, 0.02)
    pattern = "."
    if run.quick:  # ends and middle of the curves; appendix-literal is the same everywhere
        pattern = ("/(sketch|eager|ais|table|em|appendix) (0.1|0.01|0.001)/|literal 0.01/|/(one-channel|knots|quadrature|"
                   "exact|deon2011|chiang2016|marschner2003|deon2022|ou2012|pekelis2015)|loop")
    measured = run.google_benchmark("azimuthal_rivals", pattern, least, repetitions, {"TRESS_BENCH_ROWS": str(rows)})
    times = charts.by_name(measured)
    loop = {what: times[f"loop/{what}"]["median"] for what in ("evaluate", "sample")}
    domains = {}
    for one in measured:
        domain, _, rest = one["run_name"].partition("/")
        rival, _, what = rest.rpartition("/")
        if domain == "loop" or (rival in domains.get(domain, {}) and what in domains[domain][rival]):
            continue
        found = domains.setdefault(domain, {}).setdefault(rival, {})
        time = times[one["run_name"]]
        less = loop["sample" if what == "sample" else "evaluate"]
        found[what] = {key: time[key] - less for key in ("median", "low", "high")}
        if what == "evaluate":
            found["rows"], found["parts"] = one["rows"], one["parts"]
            for kind in ("error", "circle_error"):
                if f"{kind}_p50" in one:
                    found[kind] = {key: one[f"{kind}_{key}"] for key in QUANTILES}
    return {"settings": {"rows": rows, "repetitions": repetitions, "seconds_each": least, "domains": DOMAINS,
                         "time": "ns of CPU, median of the repetitions, the loop's own taken out",
                         "error": "relative squared L2 against the Fourier reference, nodes only (no grid error)",
                         "left_out": LEFT_OUT},
            "loop_ns": loop, "rivals": domains}


def draw(data, path):
    chart = charts.Chart("Azimuthal part of one lobe, a row or a direction at a time: relative squared L2 to the traced ellipse "
                         "(mark: median of rows, line up to 99 %) against CPU\nhollow marks of models: against the circle (e = 1), the "
                         "only fiber most of them know; line to the left of deon2011: its trace shared by four lobes",
                         columns=2, rows=2, width=6.4, height=4.6)
    for row, (domain, title) in enumerate(data["settings"]["domains"].items()):
        rivals = data["rivals"][domain]
        for column, what in enumerate(("evaluate", "sample")):
            axis = chart.axes[2 * row + column]
            draw_rivals(axis, rivals, what)
            aim = 8 if what == "evaluate" else 10
            axis.axvline(aim, color="#999999", linestyle=":", linewidth=1)
            axis.text(aim * 1.03, 2e-8, f"aim {aim} ns", fontsize=7, color="#666666", rotation=90, va="bottom")
            axis.set(xscale="log", yscale="log", ylim=(1e-8, 1e3), xlim=(5, 2e5),
                     xlabel="ns of CPU, " + ("value and density" if what == "evaluate" else "a sample with value and density"),
                     ylabel="relative squared L2 error",
                     title=f"{'evaluate' if what == 'evaluate' else 'sample'}: {title}")
            axis.title.set_fontsize(10)
            axis.grid(True, which="major", linewidth=0.3, alpha=0.6)
    handles, labels = chart.axes[0].get_legend_handles_labels()
    chart.axes[1].legend(handles, labels, fontsize=7, loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0)
    chart.save(path)


def draw_rivals(axis, rivals, what):
    for learner in LEARNERS:
        found = [rivals[name] for name in sorted(rivals, key=epsilon_of, reverse=True) if name.split()[0] == learner]
        if not found:
            continue
        points(axis, found, what, charts.style(learner), f"{learner} (epsilon .1 to .001)" if len(found) > 1 else learner)
    points(axis, [rivals[f"knots {k}"] for k in (32, 64, 128)], what, charts.style("table"), "knots 32, 64, 128", "--", True)
    points(axis, [rivals[f"quadrature {n}"] for n in (10, 35, 100)], what, charts.style("quadrature"),
           "ellipse by 10, 35, 100 rays")
    points(axis, [rivals["exact"]], what, charts.style("exact"), "exact, as many rays as a render takes")
    for model in CIRCULAR:
        found = [rivals[name] for name in sorted(rivals, key=epsilon_of) if name.split()[0] == model]
        label = f"{model} 10, 35, 100 points" if len(found) > 1 else model
        points(axis, found, what, charts.style(model), label, ":")
        axis.plot([one[what]["median"] for one in found], [max(one["circle_error"]["p50"], 1.3e-8) for one in found],
                  linestyle=":", linewidth=0.8, fillstyle="none", markersize=6, **charts.style(model))
        for one in found:
            if "four" in one and what == "evaluate":
                axis.hlines(one["error"]["p50"], one["four"]["median"] / 4, one[what]["median"],
                            color=charts.style(model)["color"], linewidth=1)


def points(axis, found, what, style, label, line="-", hollow=False):
    x, median = [one[what]["median"] for one in found], [max(one["error"]["p50"], 1.3e-8) for one in found]
    axis.plot(x, median, linestyle=line, linewidth=1, markersize=5, label=label, **style,
              **({"fillstyle": "none"} if hollow else {}))
    axis.vlines(x, median, [max(one["error"]["p99"], 1.3e-8) for one in found], color=style["color"], linewidth=0.6, alpha=0.5)


def epsilon_of(name):
    """The number at the end of a rival's name."""
    last = name.split()[-1]
    return float(last) if last.replace(".", "").isdigit() else 0
