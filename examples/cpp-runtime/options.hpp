// What the command line says.
#ifndef OPTIONS_HPP
#define OPTIONS_HPP

struct Options {
    bool best_effort = false;
    int seconds = 5;
    /// Whether there was something else; then the usage was printed.
    bool wrong = false;
};

Options options_of(int count, char **words);

#endif
