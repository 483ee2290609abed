// Holds what a test program called against what red.h declares: every function was called, every status was seen, every
// error that a function documents was provoked, and none came that it does not document.
//
//     (c_abi; runtime_abi) | coverage red.h
//     c_abi | coverage red.h red_runtime_
//
// Functions that begin with the second word are those of a library that was not linked.
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>

namespace {

using Names = std::set<std::string>;

/// What red.h says.
struct Header {
    std::map<std::string, int> statuses;
    std::map<std::string, Names> errors; // that the documentation of each function names
    std::map<std::string, Names> general; // that follow from the parameters of each function
};

/// What a parameter with such words in its declaration may make a call answer: rules of the whole header.
const std::pair<const char *, Names> rules[] = {
    {R"(\*)", {"RED_STATUS_NULL_POINTER", "RED_STATUS_MISALIGNED"}},
    {R"(size_t)", {"RED_STATUS_TOO_LONG"}},
    {R"(red_(scheduler|dag|runtime) \*)",
        {"RED_STATUS_CLOSED", "RED_STATUS_FOREIGN", "RED_STATUS_OTHER_KIND", "RED_STATUS_BUSY"}},
    {R"(red_callback )", {"RED_STATUS_UNKNOWN_FIELD"}},
};
/// The same of a struct that begins with its size.
const Names growing = {"RED_STATUS_STRUCT_SIZE", "RED_STATUS_VERSION", "RED_STATUS_UNKNOWN_FIELD"};

/// What no test can be sure to see: it takes more threads in the middle of this call than have room there at one instant, and a
/// lane that does not come up after it was started.
const std::set<std::pair<std::string, std::string>> rare = {
    {"red_runtime_release", "RED_STATUS_BUSY"}, {"red_runtime_wait", "RED_STATUS_SYSTEM"}};

/// All matches of the first group.
Names all(const std::string &text, const std::regex &what) {
    Names found;
    for (std::sregex_iterator at(text.begin(), text.end(), what), end; at != end; ++at) {
        found.insert((*at)[1]);
    }
    return found;
}

Header read(const std::string &text) {
    Header header;
    const std::regex status(R"((RED_STATUS_\w+) = (\d+),)");
    for (std::sregex_iterator at(text.begin(), text.end(), status), end; at != end; ++at) {
        header.statuses[(*at)[1]] = std::stoi((*at)[2]);
    }
    const Names structs = all(text, std::regex(R"(typedef struct \{[^}]*\bstruct_size;[^}]*\} (red_\w+);)"));
    // A comment, and what it is of, up to its first bracket or semicolon.
    std::map<std::string, Names> as;
    std::size_t from = 0;
    while ((from = text.find("/**", from)) != std::string::npos) {
        const std::size_t end = text.find("*/", from);
        const std::string comment = text.substr(from, end - from);
        const std::string declaration = text.substr(end + 2, text.find_first_of("({;", end) + 1 - end - 2);
        from = end;
        std::smatch name;
        if (!std::regex_search(declaration, name, std::regex(R"(\b(red_\w+)\($)"))) {
            continue;
        }
        const std::string function = name[1], errors = comment.substr(std::min(comment.find("Errors:"), comment.size()));
        header.errors[function] = all(errors, std::regex(R"((RED_STATUS_\w+))"));
        const std::size_t from_bracket = text.find('(', end);
        const std::string parameters = text.substr(from_bracket, text.find(')', from_bracket) - from_bracket);
        Names &general = header.general[function] = {"RED_STATUS_OK"};
        for (const auto &[words, statuses] : rules) {
            if (std::regex_search(parameters, std::regex(words))) {
                general.insert(statuses.begin(), statuses.end());
            }
        }
        for (const std::string &taken : all(parameters, std::regex(R"((red_\w+) \*)"))) {
            if (structs.count(taken) > 0) {
                general.insert(growing.begin(), growing.end());
            }
        }
        as[function] = all(errors, std::regex(R"(as (red_\w+))"));
        if (errors.find("those of the nodes") != std::string::npos) {
            as[function].insert("red_dag_add_node");
        }
    }
    for (const auto &[function, others] : as) {
        for (const std::string &other : others) {
            header.errors[function].insert(header.errors[other].begin(), header.errors[other].end());
        }
    }
    return header;
}

/// Takes functions that begin so out of the header, and statuses that are theirs alone.
void leave_out(Header &header, const std::string &prefix) {
    Names theirs, others;
    for (auto at = header.errors.begin(); at != header.errors.end();) {
        const bool is_out = at->first.rfind(prefix, 0) == 0;
        if (!is_out) {
            others.insert(header.general[at->first].begin(), header.general[at->first].end());
        }
        (is_out ? theirs : others).insert(at->second.begin(), at->second.end());
        at = is_out ? header.errors.erase(at) : std::next(at);
    }
    for (const std::string &status : theirs) {
        if (others.count(status) == 0) {
            header.statuses.erase(status);
        }
    }
}

} // namespace

int main(int count, char **words) {
    std::ifstream file(count > 1 ? words[1] : "");
    Header header = read(std::string(std::istreambuf_iterator<char>(file), {}));
    for (int word = 2; word < count; word++) {
        leave_out(header, words[word]);
    }
    int missing = 0;
    const auto say = [&](const std::string &what) {
        std::cout << what << '\n';
        missing++;
    };
    std::map<int, std::string> names;
    for (const auto &[name, number] : header.statuses) {
        names[number] = name;
    }
    std::map<std::string, Names> seen;
    Names seen_statuses;
    std::string line;
    while (std::getline(std::cin, line)) {
        std::smatch call;
        if (std::regex_match(line, call, std::regex(R"(call (\w+) (-?\d+))"))) {
            const std::string status = names[std::stoi(call[2])];
            if (header.errors.count(call[1]) == 0) {
                say("no function: " + line);
            }
            seen[call[1]].insert(status);
            seen_statuses.insert(status);
        } else if (line.rfind("call", 0) == 0) {
            say("no call: " + line);
        }
    }

    for (const auto &[function, errors] : header.errors) {
        if (seen.count(function) == 0) {
            say("never called: " + function);
            continue;
        }
        const Names &had = seen[function];
        if (had.count("RED_STATUS_OK") == 0) {
            say("never succeeded: " + function);
        }
        for (const std::string &error : errors) {
            if (had.count(error) == 0 && rare.count({function, error}) == 0) {
                say("never answered: " + error + " by " + function);
            }
        }
        for (const std::string &status : had) {
            if (errors.count(status) + header.general[function].count(status) == 0) {
                say("not documented: " + status + " of " + function);
            }
        }
    }
    for (const auto &[status, number] : header.statuses) {
        if (status != "RED_STATUS_INTERNAL" && seen_statuses.count(status) == 0) {
            say("never seen: " + status);
        }
    }
    std::cout << header.errors.size() << " functions, " << header.statuses.size() << " statuses, " << missing << " missing\n";
    return missing == 0 && header.errors.size() > 45 && header.statuses.size() > 40 ? 0 : 1;
}
