"""Draw a figure of the paper, to change it before it is saved."""

from emovid import paper_figure

figure = paper_figure("circumplex")
figure.set_size_inches(5, 5)
figure.savefig("circumplex.pdf")
print("circumplex.pdf")
