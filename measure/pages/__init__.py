"""What all pages share: base template, stylesheet, script, figures as inline SVG, and the summary that every page begins with."""
