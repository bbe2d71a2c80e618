// OMPL's RRTstar and BITstar on the cost map of the benchmark `routes`, with the same cost: the integral of the pace over the cells
// that an edge crosses. research/p21/benches/ompl.sh builds and runs it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <limits>
#include <memory>
#include <vector>

#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/goals/GoalRegion.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

namespace ob = ompl::base;
namespace og = ompl::geometric;

struct Map {
    int side;
    double start[2], goal[2], radius, least;
    std::vector<double> pace;

    explicit Map(const char *path) {
        std::ifstream file(path, std::ios::binary);
        double head[6];
        file.read(reinterpret_cast<char *>(head), sizeof head);
        side = static_cast<int>(head[0]);
        start[0] = head[1], start[1] = head[2], goal[0] = head[3], goal[1] = head[4], radius = head[5];
        pace.resize(static_cast<size_t>(side) * side);
        file.read(reinterpret_cast<char *>(pace.data()), static_cast<std::streamsize>(pace.size() * sizeof(double)));
        least = *std::min_element(pace.begin(), pace.end());
    }

    int index(double at) const { return std::min(std::max(static_cast<int>(at), 0), side - 1); }

    // Cell by cell, as Amanatides and Woo do it.
    double segment(const double *from, const double *to) const {
        const double dx = to[0] - from[0], dy = to[1] - from[1], length = std::hypot(dx, dy);
        int x = index(from[0]), y = index(from[1]);
        const int step_x = dx > 0 ? 1 : -1, step_y = dy > 0 ? 1 : -1;
        const double none = std::numeric_limits<double>::infinity();
        const double each_x = dx != 0 ? std::abs(1 / dx) : none, each_y = dy != 0 ? std::abs(1 / dy) : none;
        double next_x = dx != 0 ? ((dx > 0 ? x + 1 : x) - from[0]) / dx : none;
        double next_y = dy != 0 ? ((dy > 0 ? y + 1 : y) - from[1]) / dy : none;
        double done = 0, sum = 0;
        while (true) {
            const double next = std::min({next_x, next_y, 1.0});
            const double piece = (next - done) * length;
            if (piece > 1e-9) {
                sum += piece * pace[static_cast<size_t>(y) * side + x];
                if (std::isinf(sum)) return sum;
            }
            done = next;
            if (next >= 1.0) return sum;
            if (next_x <= next) x = std::min(std::max(x + step_x, 0), side - 1), next_x += each_x;
            if (next_y <= next) y = std::min(std::max(y + step_y, 0), side - 1), next_y += each_y;
        }
    }
};

static const double *values(const ob::State *state) {
    return state->as<ob::RealVectorStateSpace::StateType>()->values;
}

class TravelTime : public ob::OptimizationObjective {
  public:
    TravelTime(const ob::SpaceInformationPtr &space, const Map &map) : OptimizationObjective(space), map_(map) {
        // Admissible: the way to the goal at the least pace of the map.
        setCostToGoHeuristic([this](const ob::State *state, const ob::Goal *) {
            const double *at = values(state);
            const double away = std::hypot(map_.goal[0] - at[0], map_.goal[1] - at[1]) - map_.radius;
            return ob::Cost(map_.least * std::max(0.0, away));
        });
    }
    ob::Cost stateCost(const ob::State *) const override { return ob::Cost(0); }
    ob::Cost motionCost(const ob::State *a, const ob::State *b) const override {
        return ob::Cost(map_.segment(values(a), values(b)));
    }
    ob::Cost motionCostHeuristic(const ob::State *a, const ob::State *b) const override {
        return ob::Cost(map_.least * si_->distance(a, b));
    }

  private:
    const Map &map_;
};

class Passable : public ob::MotionValidator {
  public:
    Passable(const ob::SpaceInformationPtr &space, const Map &map) : MotionValidator(space), map_(map) {}
    bool checkMotion(const ob::State *a, const ob::State *b) const override {
        return std::isfinite(map_.segment(values(a), values(b)));
    }
    bool checkMotion(const ob::State *a, const ob::State *b, std::pair<ob::State *, double> &last) const override {
        last.second = 0;
        if (last.first) si_->copyState(last.first, a);
        return checkMotion(a, b);
    }

  private:
    const Map &map_;
};

// Arguments: map, seed, processor time for each planner in seconds. Prints planner, processor time, samples and cost as it improves.
int main(int, char **arguments) {
    ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
    ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(std::atol(arguments[2])));
    const double given = std::atof(arguments[3]);
    const Map map(arguments[1]);
    for (const bool informed : {false, true}) {
        auto space = std::make_shared<ob::RealVectorStateSpace>(2);
        space->setBounds(0, map.side);
        og::SimpleSetup setup(space);
        auto information = setup.getSpaceInformation();
        setup.setStateValidityChecker([&](const ob::State *state) {
            const double *at = values(state);
            return std::isfinite(map.pace[static_cast<size_t>(map.index(at[1])) * map.side + map.index(at[0])]);
        });
        information->setMotionValidator(std::make_shared<Passable>(information, map));
        ob::ScopedState<> start(space), goal(space);
        start[0] = map.start[0], start[1] = map.start[1], goal[0] = map.goal[0], goal[1] = map.goal[1];
        setup.setStartAndGoalStates(start, goal, std::max(map.radius, 1e-6));
        setup.setOptimizationObjective(std::make_shared<TravelTime>(information, map));
        auto tree = std::make_shared<og::RRTstar>(information);
        auto batches = std::make_shared<og::BITstar>(information);
        if (informed) {
            setup.setPlanner(batches);
        } else {
            // As far as `rrt_star_ett` goes in a step on the fastest ground, and as often to the goal.
            tree->setRange(22.5);
            tree->setGoalBias(0.05);
            setup.setPlanner(tree);
        }
        setup.setup();
        // One search, looked at while it runs: BITstar of OMPL 1.5 does not survive that it is stopped and goes on.
        const std::clock_t started = std::clock();
        const auto spent = [&] { return static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC; };
        double cost = std::numeric_limits<double>::infinity(), shown = 0;
        const auto show = [&] {
            shown = spent();
            const unsigned samples = informed ? 0 : tree->numIterations();
            std::printf("%s %.4f %u %.6f\n", informed ? "BITstar" : "RRTstar", shown, samples, cost);
        };
        setup.getProblemDefinition()->setIntermediateSolutionCallback(
            [&](const ob::Planner *, const std::vector<const ob::State *> &, const ob::Cost better) {
                cost = better.value();
                show();
            });
        unsigned asked = 0;
        setup.solve(ob::PlannerTerminationCondition([&] {
            if (++asked % 16 != 0) return false;
            const double now = spent();
            if (now > 1.02 * shown + 0.0005) show();
            return now > given;
        }));
    }
}
