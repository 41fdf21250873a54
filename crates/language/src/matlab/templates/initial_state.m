function state = scene_initial_state(p)
    %SCENE_INITIAL_STATE The state at time 0 from which the scene starts.
    %
    %   What the scene gives stays, the other coordinates and rates close the loops.
    %
    %   `p` holds the parameters: see scene_parameters. `state` is as scene_state gives it.
    [q, is_given, qd, is_given_rate] = scene_start(p);
    for iteration = 1:50
        [residuals, jacobian, rates] = scene_loop_constraints(0, q, p);
        if all(abs(residuals) <= QRM_RESIDUAL_ROUNDING)
            break
        end
        q(~is_given) = q(~is_given) - pinv(jacobian(:, ~is_given)) * residuals;
    end
    [residuals, jacobian, rates] = scene_loop_constraints(0, q, p);
    if ~all(abs(residuals) <= 1e-12)
        error('scene_initial_state: the loops cannot be closed from the guesses: %g are left', max(abs(residuals)));
    end
    for iteration = 1:2
        qd(~is_given_rate) = qd(~is_given_rate) - pinv(jacobian(:, ~is_given_rate)) * (jacobian * qd + rates);
    end
    state = scene_state(0, q, qd, p);
end
