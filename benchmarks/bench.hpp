// The benchmark harness: a row is run time against error for one method on one case.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace alpenglow::bench {

// One row of the output. Times are CPU time per item.
struct Row {
    std::string module;       // "sh"
    std::string name;         // the case: "rotate, order 5"; the rows of one case share a reference and make one plot
    std::string method;       // "scalar", "batch AVX2", "reference"
    double time_ns = 0.0;     // median over repetitions, per item
    double time_spread = 0.0; // (third quartile - first quartile) / median
    double error = 0.0;       // 0 for the reference itself
    std::string error_metric; // norm, domain and unit: "max relative, 1e5 random directions"
    std::string reference;    // what the error is measured against
    double bytes = 0.0;       // memory that the method reads or holds, 0 where it means nothing
    double items = 1.0;       // items a call
};

struct Time {
    double ns = 0.0;
    double spread = 0.0;
};

class Context {
public:
    Context(bool quick, std::vector<Row>& rows) : quick_(quick), rows_(rows) {}

    // True in --quick runs: fewer repetitions, smaller domains for the errors.
    [[nodiscard]] bool quick() const { return quick_; }

    // CPU time per item of `call`, which processes `items` items: the median over repetitions, each long enough to
    // measure, after a warm-up.
    [[nodiscard]] Time time(double items, const std::function<void()>& call) const;

    // Adds a row; fills time from `time` and leaves the rest as given.
    void add(Row row) const { rows_.push_back(std::move(row)); }

    // Short form: measures `call` and adds the row.
    void run(Row row, const std::function<void()>& call) const {
        const Time t = time(row.items, call);
        row.time_ns = t.ns;
        row.time_spread = t.spread;
        add(std::move(row));
    }

private:
    bool quick_;
    std::vector<Row>& rows_;
};

// Keeps the optimiser from dropping a result.
template <class T>
inline void keep(const T& value) {
    asm volatile("" : : "r,m"(value) : "memory");
}

// Registers a case function under "module/name"; --filter and --list see that name.
struct Case {
    Case(std::string name, std::function<void(const Context&)> body);
};

} // namespace alpenglow::bench
