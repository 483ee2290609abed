// What the C++ tests share.
#ifndef TESTS_HPP
#define TESTS_HPP

#include "../check.h"

#include <array>
#include <red.hpp>
#include <string>

using namespace std::chrono_literals;

using Small = red::Caps4x16x16;

/// An instant of virtual time.
constexpr red::Time at(red::Nanoseconds since) { return red::Time(since); }

/// Whether a call ended so.
template <class Answer>
bool ended(const Answer &answer, red_status expected) {
    if (answer.status() == expected) {
        return true;
    }
    std::fprintf(stderr, "%s, expected: %s\n", answer.status().text(), red_status_text(expected));
    return false;
}

#endif
