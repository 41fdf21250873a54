function motion = scene_motion(p, step)
    %SCENE_MOTION The motion from the scene's start to its stop condition.
    %
    %   motion = scene_motion() takes the scene's parameters and step. Other ones can be given: the parameters `p`
    %   (see scene_parameters) and the length of a step in s.
    %
    %   The fields of `motion` have a row for each step: t, q, qd, qdd, multipliers, outputs and residual, the largest
    %   residual of a constraint. The last row is where the stop condition becomes true.
    if nargin < 1
        p = scene_parameters();
    end
    [scene_step, end_time] = scene_schedule(p);
    if nargin < 2
        step = scene_step;
    end
    if ~(isscalar(step) && step > 0)
        error('scene_motion: the length of a step must be a number above 0, in s');
    end
    t = 0;
    state = scene_initial_state(p);
    event = scene_event(t, state.q, state.qd, state.qdd, state.multipliers, p);
    rows = row(t, state, 0, p);
    count = 1;
    while t < end_time
        % Steps begin at multiples of their length.
        next_t = min(count * step, end_time);
        [next, residual] = scene_rk4_step(t, next_t - t, state, p);
        next_event = scene_event(next_t, next.q, next.qd, next.qdd, next.multipliers, p);
        is_end = event < 0 && next_event >= 0;
        if is_end
            h = time_of_event(t, next_t - t, event, next_event, state, p);
            [next, residual] = scene_rk4_step(t, h, state, p);
            next_t = t + h;
        end
        [t, state, event] = deal(next_t, next, next_event);
        count = count + 1;
        if count > size(rows, 1)
            rows = [rows; zeros(size(rows))];
        end
        rows(count, :) = row(t, state, residual, p);
        if is_end
            break
        end
    end
    rows = rows(1:count, :);
    n = numel(state.q);
    ends = cumsum([1, n, n, n, numel(state.multipliers)]);
    motion = struct('t', rows(:, 1), 'q', rows(:, ends(1)+1:ends(2)), 'qd', rows(:, ends(2)+1:ends(3)), ...
        'qdd', rows(:, ends(3)+1:ends(4)), 'multipliers', rows(:, ends(4)+1:ends(5)), ...
        'outputs', rows(:, ends(5)+1:end-1), 'residual', rows(:, end));
end

function numbers = row(t, state, residual, p)
    outputs = scene_outputs(t, state.q, state.qd, state.qdd, state.multipliers, p);
    numbers = [t; state.q; state.qd; state.qdd; state.multipliers; outputs; residual].';
end

function h = time_of_event(t, step, before, after, state, p)
    % The length of the step from `t` to the event, by the method of false position in the variant of Illinois.
    [low, high] = deal(0, step);
    for iteration = 1:100
        h = (low * after - high * before) / (after - before);
        next = scene_rk4_step(t, h, state, p);
        event = scene_event(t + h, next.q, next.qd, next.qdd, next.multipliers, p);
        if event == 0 || high - low <= eps(t + step)
            break
        elseif event < 0
            if low > 0 && iteration > 1 && is_low
                after = after / 2;
            end
            [low, before, is_low] = deal(h, event, true);
        else
            if high < step && iteration > 1 && ~is_low
                before = before / 2;
            end
            [high, after, is_low] = deal(h, event, false);
        end
    end
end
