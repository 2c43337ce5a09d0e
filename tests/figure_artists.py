"""What a figure shows, read from its artists."""


def line_data(axes, number=0):
    """Abscissae and ordinates of a line."""
    return axes.get_lines()[number].get_data()


def labelled(axes, label):
    """The one line with a label."""
    (line,) = (line for line in axes.get_lines() if line.get_label() == label)
    return line.get_data()


def legend_texts(figure):
    """Labels of a page's legend."""
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def look(line):
    """What tells a line from others in grey."""
    return line.is_dashed(), line.get_marker()


def span_edges(patch):
    """Where a shaded span begins and ends, in data; matplotlib before 3.9 makes it a polygon."""
    return patch.get_extents().transformed(patch.axes.transData.inverted()).intervalx.tolist()
